! SPDX-License-Identifier: Apache-2.0
! RAPID: scan, then move over the best grasp of part 1.
MODULE PickPart
  VAR socketdev geond;
  VAR string line;
  VAR num record{11};
  VAR pose grasp;
  VAR bool ok;

  PROC Ask(string question)
    SocketSend geond \Str:=question + "\0A";
    SocketReceive geond \Str:=line \Time:=5;
    ! StrToVal wants the value alone, without the end of the line.
    line := StrPart(line, 1, StrLen(line) - 1);
  ENDPROC

  PROC PickPart()
    SocketCreate geond;
    SocketConnect geond, "192.168.1.10", 7110;
    Ask "DIALECT ABB";
    Ask "SCAN";
    record{1} := 1;
    WHILE record{1} = 1 DO
      WaitTime 0.5;
      Ask "STATUS";
      ok := StrToVal(line, record);
    ENDWHILE
    Ask "GRASP 1";
    ok := StrToVal(line, grasp);
    IF ok AND record{1} = 0 AND VectMagn(grasp.trans) > 0 THEN
      MoveL RelTool([grasp.trans, NOrient(grasp.rot), [0,0,0,0], [9E9,9E9,9E9,9E9,9E9,9E9]], 0, 0, -100), v100, fine, tool0;
    ENDIF
    SocketClose geond;
  ENDPROC
ENDMODULE
